; --expand no_return.nc:7:1: `G1 X5`: the subprogram ends here without M99, endsub, M17, RET or LBL 0; expected its own of them
G21 G90 G17 F100
G0 X0 Y0 Z5
M98 P100
M30
O100
G1 X5
