; subprogram.nc:4:1: `M98`: subprograms are not read; expected one program, or expand in [gcode] of the process file (--expand), which writes it out
G21 G90 G17 F100
G0 X0 Y0 Z5
M98 P100
