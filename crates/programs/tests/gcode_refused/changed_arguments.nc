; --expand changed_arguments.nc:9:1: `M99`: a macro that is repeated changes its arguments, which controls read differently; expected L1
G21 G90 G17 F100
G0 X0 Y0 Z5
G65 P100 A1 L2
M30
O100
G1 X#1
#1=#1+1
M99
