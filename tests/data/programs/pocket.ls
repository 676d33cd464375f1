/PROG RANDOM
/ATTR
OWNER = MNEDITOR;
/MN
   1:UFRAME_NUM=1 ;
   2:UTOOL_NUM=1 ;
   3:L P[1] 500mm/sec FINE ;
   4:CALL SPINDLE(6000) ;
   5:L P[2] 60cm/min FINE ;
   6:L P[3] 60cm/min FINE ;
   7:L P[4] 500mm/sec FINE ;
   8:L P[5] 10mm/sec FINE ;
   9:L P[6] 60cm/min FINE ;
  10:L P[7] 500mm/sec FINE ;
  11:L P[8] 1.5mm/sec FINE ;
  12:WAIT   3.0(sec) ;
  13:L P[9] 500mm/sec FINE ;
  14:WAIT   1.5(sec) ;
  15:L P[10] 500mm/sec FINE ;
  16:L P[11] 500mm/sec FINE ;
/POS
P[1] {
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 0 mm,	Y = 0 mm,	Z = 60 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[2]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = -16.976 mm,	Y = 22.854 mm,	Z = 50.491 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[3]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 40.842 mm,	Y = 33.115 mm,	Z = 50.491 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[4]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = -15.385 mm,	Y = 44.213 mm,	Z = 50.491 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[5]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 27.742 mm,	Y = -11.022 mm,	Z = 10.925 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[6] {
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 31.431 mm,	Y = -51.368 mm,	Z = 37.076 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[7] {
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = -34.865 mm,	Y = -34.142 mm,	Z = 58.945 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[8]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 55.377 mm,	Y = 4.707 mm,	Z = 58.945 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[9]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 55.812 mm,	Y = -14.013 mm,	Z = 1.294 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[10]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 38.088 mm,	Y = 10.337 mm,	Z = 35.759 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
P[11] {
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 38.222 mm,	Y = -2.311 mm,	Z = 18.948 mm,
	W = 180 deg,	P = 0 deg,	R = 0 deg
};
/END
