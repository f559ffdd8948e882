MODULE part
  ! Header
  ! MODULE nothing
  PROC main()
    ! MoveL p1,v10,fine,tool0;
    MoveL [[1,2,3],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,fine,tool0;! first; not last

    MoveL   [[21,2,3],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]] , v10 , z50 \Inpos:=inpos50 , tool0 \WObj:=wobj0 ;
    TPWrite "MoveL ! " ;
  ENDPROC
ENDMODULE
