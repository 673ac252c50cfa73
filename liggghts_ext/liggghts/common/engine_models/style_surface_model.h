// The engine's headers include its lists of contact models, which its build generates and its
// package omits. The headers name this one model:
#ifdef SURFACE_MODEL
SURFACE_MODEL(SURFACE_DEFAULT, default, 0)
#endif
