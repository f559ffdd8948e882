; --expand no_label.nc:4:1: `GOTO 20`: its other end is not in the program; expected the label, or the word that ends or begins the same loop, branch or subprogram
G21 G90 G17 F100
G0 X0 Y0 Z5
GOTO 20
