# What firmware does to the numbers of its output.
codes-signed-low = the low byte was joined as a signed number
codes-signed-low-or = the low byte was joined by OR as a signed number, which wipes out the high byte
codes-bytes = the bytes were exchanged
codes-unsigned = two's complement was read as an unsigned number
codes-wrap = the number wraps at full scale, every { $codes } codes
codes-stuck-high = one bit is always set
codes-stuck-low = one bit is always clear
codes-torn = the high byte is that of the preceding row
