; --expand runs_on.nc:4:1: `O100`: the program runs into another one; expected M2, M30 or M99 before it
G21 G90 G17 F100
G0 X0 Y0 Z5
O100
G1 X5
M99
