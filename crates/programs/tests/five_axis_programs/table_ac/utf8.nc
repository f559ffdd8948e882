; Tasche auf schräger Fläche – 5 Achsen, Ø8
G21 G90
G43.4 H3 ; Spitze geführt
G0 X5 Y5 Z15 A20 C30
G1 Z0 F250 ; eintauchen
X30 A22 C36
Y20 ; quer
X5 A20 C30
G0 Z15
M30
