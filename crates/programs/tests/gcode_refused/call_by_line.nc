; --expand call_by_line.nc:4:10: `Q20`: Q of a call is not read: controls differ in what it means; expected P, L and, after G65, arguments
G21 G90 G17 F100
G0 X0 Y0 Z5
M98 P100 Q20
