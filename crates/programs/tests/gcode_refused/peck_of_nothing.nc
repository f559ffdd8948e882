; --expand peck_of_nothing.nc:4:15: `Q0`: not a peck of a hole 8.000 mm deep; expected Q above 0, at least 1/10000 of the depth, and with a point if it is more
G21 G90 G17 F100
G0 X0 Y0 Z5
G83 X5 Z-6 R2 Q0 F50
