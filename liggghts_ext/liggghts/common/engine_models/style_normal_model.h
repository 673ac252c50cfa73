// The engine's headers include its list of normal models, which its build generates and its package
// omits. Not needed here.
