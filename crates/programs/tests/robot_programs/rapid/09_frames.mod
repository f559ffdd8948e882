MODULE part
  PERS tooldata tcut:=[TRUE,[[31.5,0,229],[0.70710678,0,0.70710678,0]],[3,[0,0,80],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata w1:=[FALSE,TRUE,"",[[1000,0,500],[1,0,0,0]],[[0,100,0],[1,0,0,0]]];
  TASK PERS wobjdata w2:=[FALSE,TRUE,"",[[1000,100,500],[1,0,0,0]],[[20,50,0],[0.70710678,0,0,0.70710678]]];
  PROC main()
    MoveL [[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tcut\WObj:=w1;
    MoveL [[20,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tcut\WObj:=w1;
    MoveL [[0,-20,0],[0.5,0.5,0.5,-0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tcut\WObj:=w2;
  ENDPROC
ENDMODULE
