; --expand modal_macro.nc:4:1: `G66 P9010 X5`: macro calls that stay in force (G66) are not followed; expected G65, or the macro written out
G21 G90 G17 F100
G0 X0 Y0 Z5
G66 P9010 X5
