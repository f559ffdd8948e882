; unknown_word.nc:4:1: `G112`: this G word is not supported; expected a word of a 3-axis mill program
G21 G90 G17 F100
G0 X0 Y0 Z5
G112 X5
