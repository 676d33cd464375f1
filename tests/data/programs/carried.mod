MODULE Carried
  PERS tooldata tStand:=[FALSE,[[700,-150,500],[1,0,0,0]],[3,[0,0,40],[1,0,0,0],0,0,0]];
  PERS tooldata tSpindle:=[TRUE,[[0,0,150],[1,0,0,0]],[4,[0,0,50],[1,0,0,0],0,0,0]];
  PERS wobjdata wPart:=[TRUE,TRUE,"",[[0,0,160],[1,0,0,0]],[[10,20,0],[1,0,0,0]]];
  PERS wobjdata wTable:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,30],[1,0,0,0]]];
  CONST robtarget p1:=[[0,0,0],[0,1,0,0],[0,0,0,0],[9E9,10,0,9E9,9E9,9E9]];
  PROC main()
    VAR robtarget here;
    SPINDLE 3000;
    GripLoad [1,[0,0,20],[1,0,0,0],0,0,0];
    MoveJ p1,v100,fine,tStand\WObj:=wPart;
    MoveL Offs(p1,20,0,0),v10,fine,tStand\WObj:=wPart;
    here:=CRobT(\Tool:=tStand\WObj:=wPart);
    MoveC Offs(here,10,10,0),Offs(here,0,20,0),v10,fine,tStand\WObj:=wPart;
    MoveJ p1,v100,fine,tSpindle\WObj:=wTable;
    MoveL [[10,0,0],[0,1,0,0],[0,0,0,0],[9E9,-20,15,9E9,9E9,9E9]],v10,fine,tSpindle\WObj:=wTable;
    WaitTime 1;
    MoveAbsJ [[0,0,0,0,30,0],[9E9,0,0,9E9,9E9,9E9]],v100,fine,tStand;
  ENDPROC
  PROC SPINDLE(num rpm)
  ENDPROC
ENDMODULE
