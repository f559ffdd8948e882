; scaling.nc:4:1: `G51`: polar, scaled or rotated coordinates are not supported; expected plain coordinates
G21 G90 G17 F100
G0 X0 Y0 Z5
G51 X0 Y0 P2
