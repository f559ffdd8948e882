; --expand for_ever.nc:4:4: `GOTO 1`: the program has run 1000000 lines and has not ended; expected one that ends
G21 G90 G17 F100
G0 X0 Y0 Z5
N1 GOTO 1
