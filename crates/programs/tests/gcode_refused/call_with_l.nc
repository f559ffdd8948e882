; --expand call_with_l.nc:4:10: `L2.5`: expected a whole number after L
G21 G90 G17 F100
G0 X0 Y0 Z5
M98 P100 L2.5
