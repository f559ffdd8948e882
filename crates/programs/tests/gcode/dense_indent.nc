  G21	G90
	G0 X0  Y0   Z1
	  G1   Z-1	F90   (deep)
	  G2  X10   Y0  I5   J0   ( half )   F300   ; end
      X0 Y0 I-5 J0
	  Y-4   G1
M30
