# What firmware does to the numbers of its output.
codes-signed-low = the low byte was joined as a signed number
codes-signed-low-or = the low byte was joined by OR as a signed number, which wipes out the high byte
codes-bytes = the bytes were exchanged
codes-unsigned = two's complement was read as an unsigned number
codes-wrap = the number wraps at full scale, every { $size }
codes-stuck-high = one bit is always set
codes-stuck-low = one bit is always clear
codes-size = { $codes } codes
codes-jump = { $jump }
codes-suspected = The readings of { $channel } jump by about { $size }, as if { $bug }; but what a tap or a shock leaves would look much the same, so nothing was changed. A slow turn through the jump, or a rest beyond it, would decide.
codes-torn = the high byte is that of the preceding row

# Of a result whose readings were put right.
validity-codes-put-right = Wrong output codes of { $channels } were put right exactly before anything was computed: { $bug }, so that up to { $share } % of a channel's readings were off by multiples of { $size }. The recording itself is unchanged; correct the firmware.
validity-codes-undecided = Wrong output codes of { $channels } could not be put right reading by reading: { $bug }, and readings are off by multiples of { $size }{ $segments ->
        [0] {""}
        [one] {" "}(undecided in 1 segment)
       *[other] {" "}(undecided in { $segments } segments)
    }. Correct the firmware and measure again.
