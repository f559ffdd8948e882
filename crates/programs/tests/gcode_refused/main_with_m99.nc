; --expand main_with_m99.nc:5:1: `M99`: ends a subprogram where none was called, or repeats the main program for ever; expected M2 or M30, or start_mm in [gcode], from where the program runs as a subprogram
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X5
M99
