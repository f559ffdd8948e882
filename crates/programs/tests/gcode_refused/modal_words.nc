; modal_words.nc:4:4: `G1`: contradicts G0 on the same line; expected one of them
G21 G90 G17 F100
G0 X0 Y0 Z5
G0 G1 X5
