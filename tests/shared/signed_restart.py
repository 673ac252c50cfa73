"""Restart files with the signature of `fix mill/restart` and a few bytes in place of balls."""

import zlib


def restart_file(part, name, step, loop_time=0.0, processor_time=0.0):
    """Write a signed restart file of a step into a folder."""
    content = f"balls at step {step}".encode()
    signature = (
        f"\nmillscale restart step {step} bytes {len(content)} crc32 {zlib.crc32(content):08x} "
        f"loop_time_s {loop_time:.6f} processor_time_s {processor_time:.6f}\n"
    )
    (part / name).write_bytes(content + signature.encode())
