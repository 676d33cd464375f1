MODULE Contour
  ! Contour of a bracket, 160 x 100 mm with rounded corners.
  PERS tooldata tSpindle := [TRUE, [[0, 0, 150], [1, 0, 0, 0]], [4.2, [0, 0, 70], [1, 0, 0, 0], 0, 0, 0]];
  PERS wobjdata wFixture := [FALSE, TRUE, "", [[760, -50, 430], [1, 0, 0, 0]], [[0, 0, 0], [1, 0, 0, 0]]];
  CONST speeddata vCut := [10, 500, 5000, 1000];
  CONST robtarget p10 := [[20, 0, 0], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget p20 := [[140, 0, 0], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget p30 := [[154.142, 5.858, 0], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget p40 := [[160, 20, 0], [0, 0, 1, 0], [-1, 0, -1, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];

  PROC main()
    SetDO doCoolant, 1;
    MoveJ Offs(p10, 0, 0, 40), v200, z10, tSpindle \WObj:=wFixture;
    MoveL p10, v20, fine, tSpindle \WObj:=wFixture;
    Contour;
    MoveL Offs(p10, 0, 0, 40), v200, z10, tSpindle \WObj:=wFixture;
    SetDO doCoolant, 0;
  ENDPROC

  PROC Contour()
    MoveL p20, vCut, z1, tSpindle \WObj:=wFixture;
    MoveC p30, p40, vCut, z1, tSpindle \WObj:=wFixture;
    MoveL Offs(p40, 0, 80, 0), vCut, z1, tSpindle \WObj:=wFixture;
    MoveL Offs(p10, 0, 100, 0), vCut, z1, tSpindle \WObj:=wFixture;
    MoveL p10, vCut, fine, tSpindle \WObj:=wFixture;
  ENDPROC
ENDMODULE
