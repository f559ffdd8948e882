; variable.nc:4:1: `#100=5`: variables and expressions are not read; expected plain numbers, or expand in [gcode] of the process file (--expand), which writes it out
G21 G90 G17 F100
G0 X0 Y0 Z5
#100=5
