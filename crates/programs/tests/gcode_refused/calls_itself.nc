; --expand calls_itself.nc:7:1: `M98 P100`: calls are more than 50 deep; expected subprograms that do not call themselves
G21 G90 G17 F100
G0 X0 Y0 Z5
M98 P100
M30
O100
M98 P100
M99
