; after_the_end.nc:5:4: `X5`: a motion after the end of the program in line 4; expected none
G21 G90 G17 F100
G0 X0 Y0 Z5
M30
G0 X5
