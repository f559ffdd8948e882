%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE part
  PROC main()
    ConfL\Off;
    SingArea\Wrist;
    MoveJ [[0,0,50],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,z10,tool0;
    MoveL [[0.0,0.0,0.0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,fine,tool0;
    MoveL [[40.000,0.000,0.000],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,z1,tool0;
    SetDO doSpindle,0;
  ENDPROC
ENDMODULE
