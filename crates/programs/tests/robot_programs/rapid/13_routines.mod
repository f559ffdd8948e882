MODULE routines
  PROC main()
    Prepare;
    Path_10;
    Spindle_Off;
  ENDPROC
  LOCAL PROC Prepare()
    ConfL\Off;
    VelSet 100,5000;
  ENDPROC
  PROC Path_10()
    MoveL [[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;
    MoveL [[20,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;
  ENDPROC
  FUNC num half(num x)
    RETURN x/2;
  ENDFUNC
ENDMODULE
