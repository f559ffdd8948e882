MODULE part
  PERS num depth:=0;
  PROC main()
    IF depth>1 THEN
      TPWrite "deep";
    ELSEIF depth=0 THEN
      Reset do1;
    ELSE
      Set do1;
    ENDIF
    TEST mode
    CASE 1:
      WaitTime 1;
    DEFAULT:
      WaitTime 2;
    ENDTEST
    WHILE di1=0 DO
      WaitTime 0.1;
    ENDWHILE
    IF di2=1 Set do3;
    start:
    depth := depth+1;
    MoveL [[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;
    MoveL [[20,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;
  ENDPROC
ENDMODULE
