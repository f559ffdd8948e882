; thread_cycle.nc:4:1: `G76`: this canned cycle is not supported; expected the cycle written out as G0 and G1 moves
G21 G90 G17 F100
G0 X0 Y0 Z5
G76 P1.5 Z-20 I-1 J0.2 K0.6 R1.5 Q29.5
