// The engine's headers include its list of rolling models, which its build makes and its package
// leaves out. Not needed here.
