; cycle_in_g18.nc:4:5: `G81`: cycles are read in G17 only; expected the cycle written out as G0 and G1 moves
G21 G90 G17 F100
G0 X0 Y0 Z5
G18 G81 X5 Z-5 R2
