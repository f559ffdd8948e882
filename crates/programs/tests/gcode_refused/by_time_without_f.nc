; by_time_without_f.nc:4:5: `G1`: inverse time feed (G93) without an F on the line; expected one on each line with G1, G2 or G3
G21 G90 G17 F100
G0 X0 Y0 Z5
G93 G1 X5
