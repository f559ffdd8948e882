; manual_bore.nc:4:1: `G88`: this canned cycle is not supported; expected the cycle written out as G0 and G1 moves
G21 G90 G17 F100
G0 X0 Y0 Z5
G88 X5 Y5 Z-5 R2
