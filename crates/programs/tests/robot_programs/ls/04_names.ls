/PROG  NAMES
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 636;
CREATE		= DATE 25-03-04  TIME 08:00:00;
LINE_COUNT	= 10;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/APPL
/MN
   1:  !name ; and more ;
   2:  //L P[9] 20mm/sec FINE    ;
   3: ;
   4:  --eg:start ;
   5:  UFRAME_NUM=1 ;
   6:  UTOOL_NUM=1 ;
   7:L P[1:start] 20mm/sec FINE    ;
   8:  DO[1]=ON ;
   9:L P[2:cut] 20mm/sec FINE    ;
  10:  WAIT    .50(sec) ;
/POS
P[1:"start"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     1.500  mm,	Y =     2.500  mm,	Z =     3.500  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2:"cut"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    31.500  mm,	Y =     2.500  mm,	Z =     3.500  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
