; rotation.nc:4:1: `G68`: polar, scaled or rotated coordinates are not supported; expected plain coordinates
G21 G90 G17 F100
G0 X0 Y0 Z5
G68 X0 Y0 R30
