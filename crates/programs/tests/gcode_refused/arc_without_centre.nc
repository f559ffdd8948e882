; arc_without_centre.nc:4:1: `G2`: arc without a centre; expected I and J in G17, or R
G21 G90 G17 F100
G0 X0 Y0 Z5
G2 X5 Y5
