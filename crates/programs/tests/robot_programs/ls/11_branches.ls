/PROG  BRANCHES
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 636;
CREATE		= DATE 25-03-04  TIME 08:00:00;
LINE_COUNT	= 19;
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
   3:L P[1] 20mm/sec FINE    ;
   4:  CALL SPINDLE_ON     ;
   5:  IF (DI[1]=ON) THEN ;
   6:  DO[2]=ON ;
   7:  ELSE ;
   8:  DO[2]=OFF ;
   9:  ENDIF ;
  10:  FOR R[1]=1 TO 3 ;
  11:  R[2]=R[2]+1 ;
  12:  ENDFOR ;
  13:  SELECT R[1]=1,CALL SPINDLE_ON ;
  14:         =2,CALL SPINDLE_OFF ;
  15:         ELSE,CALL SPINDLE_OFF ;
  16:  LBL[1] ;
  17:L P[2] 20mm/sec FINE    ;
  18:  CALL SPINDLE_OFF     ;
  19:  END ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.000  mm,	Y =     0.000  mm,	Z =     0.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    20.000  mm,	Y =     5.000  mm,	Z =     0.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
