MODULE part
  CONST robtarget pCorner:=[[100,0,20.5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ Offs(pCorner,0,0,50),v300,z5,tool0;
    MoveL Offs(pCorner,0,0,30),v10,z0,tool0;
    MoveL Offs(pCorner,20,0,30),v10,z0,tool0;
    MoveL Offs(pCorner,20,20,20),v10,z0,tool0;
    MoveL Offs ( pCorner , 20 , 20 , 0 ) ,v10,fine,tool0;
  ENDPROC
ENDMODULE
