MODULE part
  PROC main()
    MoveL [[0,0,0],[0,0,1,0],[0,0,0,0],[100,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;
    ActUnit STN1;
    MoveL [[20,0,0],[0,0,1,0],[0,0,0,0],[150.0,9E+09,9E9,9E9,9E9,9E9]],v10,fine,tool0;
  ENDPROC
ENDMODULE
