; tool_centre_point.nc:4:1: `G43.4`: tool centre point control of rotary axes is not supported; expected rotary axes that stand still and G43
G21 G90 G17 F100
G0 X0 Y0 Z5
G43.4 H1
