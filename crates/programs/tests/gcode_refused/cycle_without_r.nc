; cycle_without_r.nc:4:1: `G81`: cycle G81 without R; expected R and Z on this line or one before it
G21 G90 G17 F100
G0 X0 Y0 Z5
G81 X5 Y5 Z-5
