; probe.nc:4:1: `G38.2`: this motion is not supported; expected G0, G1, G2 or G3
G21 G90 G17 F100
G0 X0 Y0 Z5
G38.2 Z-10 F50
