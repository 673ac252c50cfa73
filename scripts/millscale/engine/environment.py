"""Environment variables of millscale."""

# Path of the engine's executable, in place of the one that is installed.
ENGINE_VARIABLE = "MILLSCALE_ENGINE"
# The command line that a person typed; `millscale run` passes it to the stages.
COMMAND_VARIABLE = "MILLSCALE_COMMAND"
# Longest wall time of a stage [s]; `millscale run --time-limit` passes it to the stages.
TIME_LIMIT_VARIABLE = "MILLSCALE_TIME_LIMIT_S"
