%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%

MODULE Fraesen
  ! Tasche fräsen, Wand stützen
  TASK PERS tooldata tSpindel:=[TRUE,[[0,0,150],[0.7071068,0,0.7071068,0]],[6.5,[0,0,80],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata wTisch:=[FALSE,TRUE,"",[[900,0,400],[0.7071068,0,0,0.7071068]],[[10,20,0],[1,0,0,0]]];
  CONST robtarget p10:=[[100,0,50],[0,1,0,0],[0,-1,0,1],[9E9,9E+09,9E9,9E9,9E9,9E9]];
  CONST robtarget pRow{2}:=[[[1.5E+02,0,5E1],[-0.0,-1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
                            [[150,40,50],[0.002,0.999,0.002,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
  CONST jointtarget jHome:=[[0,20,-10,0,60,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS speeddata vCut:=[12.5,200,5000,1000];
  VAR num depth:=2;

  PROC main()
    VAR num i;
    ConfL \Off;
    SingArea \Wrist;
    AccSet 50,50;
    SetDO doSpindel,1;
    MoveAbsJ jHome\NoEOffs,v200,fine,tool0;
    MoveJ p10,v100,z10,tSpindel\wobj:=wTisch;
    MoveL Offs(p10,0,0,-depth),vCut,fine,tSpindel\WObj:=wTisch;
    cut pRow{1},vCut;
    FOR i FROM 1 TO 3 DO
      MoveL Offs(pRow{1},0,10*i,0),v50\V:=8,z1,tSpindel\WObj:=wTisch;
    ENDFOR
    MoveL
      [[150,40,50],[0,1,0,0],[0,0,0,0],
       [9E9,9E9,9E9,9E9,9E9,9E9]],
      vCut, z0, tSpindel \WObj:=wTisch;
    MoveL RelTool(p10,1,2,3\Rz:=90),v5,fine,tSpindel\WOBJ:=wTisch;
    MoveC pRow{2},Offs(p10,0,80,0),vCut,z1,tSpindel\WObj:=wTisch;
    TPWrite "fertig ! kein Kommentar";
    IF DInput(diTuer)=1 TPWrite "offen";
  ENDPROC

  LOCAL PROC cut(robtarget at,speeddata speed\switch back)
    MoveL at,speed,z0,tSpindel\WObj:=wTisch;
    IF Present(back) MoveL p10,speed,z0,tSpindel\WObj:=wTisch;
  ENDPROC
ENDMODULE
