// The engine's headers include its lists of contact models, which its build makes and its package
// leaves out. The one they name themselves:
#ifdef SURFACE_MODEL
SURFACE_MODEL(SURFACE_DEFAULT, default, 0)
#endif
