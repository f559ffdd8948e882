/PROG  JOINTS
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 636;
CREATE		= DATE 25-03-04  TIME 08:00:00;
LINE_COUNT	= 6;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/APPL
/MN
   1:  UFRAME_NUM=1 ;
   2:  UTOOL_NUM=1 ;
   3:J P[1] 100% FINE    ;
   4:L P[2] 20mm/sec FINE    ;
   5:L P[3] 20mm/sec FINE    ;
   6:J P[1] 100% FINE    ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,	
	J1=     0.000 deg,	J2=   -20.000 deg,	J3=    15.500 deg,
	J4=     0.000 deg,	J5=   -75.000 deg,	J6=     0.000 deg
};
P[2]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    10.000  mm,	Y =     0.000  mm,	Z =     5.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[3]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    30.000  mm,	Y =     0.000  mm,	Z =     5.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
