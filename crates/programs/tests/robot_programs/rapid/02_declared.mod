MODULE part
  CONST robtarget p10:=[[10,20,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p20:=[[30.00,20.00,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL PERS robtarget p30 := [[30,35,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]] ;
  CONST speeddata vCut:=[15,500,5000,1000];
  PERS num depth:=2;
  PROC main()
    MoveJ p10,v200,fine,tMill\WObj:=wPart;
    MoveL p20,vCut,z1,tMill\WObj:=wPart;
    MoveL p30,vCut,z1,tMill\WObj:=wPart;
    MoveL p10,vCut,fine,tMill\WObj:=wPart;
  ENDPROC
ENDMODULE
