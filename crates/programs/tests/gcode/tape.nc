%
:1000 (tape)
N1 G 21 G 90
N2 G0 X 0 Y 0 Z 2.5
N3 G1 Z -1.5 F 100
N4 X 12.5 Y -3
N5 Y 14.
M30
%
Program of the morning shift, see page 12
