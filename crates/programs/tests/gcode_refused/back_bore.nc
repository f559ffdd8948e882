; back_bore.nc:4:5: `G87`: this canned cycle is not supported; expected the cycle written out as G0 and G1 moves
G21 G90 G17 F100
G0 X0 Y0 Z5
G98 G87 X5 Y5 Z-5 R-8 Q0.5
