MODULE part
  VAR speeddata vMine:=[40,500,5000,1000];
  PROC main()
    MoveL [[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v20,z1,tool0;
    MoveL [[5,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],[12.5,500,0,0],z1,tool0;
    MoveL [[10,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100\V:=5,z1,tool0;
    MoveL [[15,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],vMine,z1,tool0;
    MoveL [[20,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],vmax,z1,tool0;
    MoveL [[25,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],vElse,z1,tool0;
  ENDPROC
ENDMODULE
