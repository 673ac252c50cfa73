// The engine's headers include its list of rolling models, which its build generates and its
// package omits. Not needed here.
