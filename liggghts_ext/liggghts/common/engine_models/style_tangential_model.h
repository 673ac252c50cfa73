// The engine's headers include its list of tangential models, which its build makes and its package
// leaves out. Not needed here.
