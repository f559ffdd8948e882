; tool_vectors.nc:4:1: `G43.5`: tool axes as vectors (G43.5) are not supported; expected angles of rotary axes with G43.4
G21 G90 G17 F100
G0 X0 Y0 Z5
G43.5 H1
