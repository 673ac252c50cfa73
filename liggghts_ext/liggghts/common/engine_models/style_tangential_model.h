// The engine's headers include its list of tangential models, which its build generates and its
// package omits. Not needed here.
