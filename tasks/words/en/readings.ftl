## How the specifications' clauses were read where they are wrong or silent: reading-<specification>-<what>.

reading-jjf2003-p-turning = U_7 is the mean at rest (7.2.5.1 a) and U_8 the mean while turning (7.2.5.1 b); the text under the equations calls both “at rest”.
reading-jjf2003-p-sign = Eq. (12), (13) give rest minus turning, which is the negative of p in model (2). The value by (12), (13) is the clause's result; the value with the sign of model (2) is stored beside it and is the one to compensate with.
reading-jjf2003-p-lever-arm = With the accelerometers at r from the rotation axis, eq. (12), (13) return the components of r (in metres) on top of the sensor's own p; the value holds for the mounting position of this calibration.
reading-jjf2003-p-rates = The clause does not state the rate: the largest rate of the run is used, averaged over the directions recorded, relative to the mean of the adjacent rests.
reading-jjf2003-p-unit = p is given in m/s² per (rad/s)², that is, in metres.
reading-jjf2003-g-earth = The 180° pairs of 7.2.2.1 cancel only the horizontal component of Earth's rotation; the diagonal of the g-sensitivity by eq. (7) is too large by ω_e·sin φ per g. Both the value by the clause and the value without Earth's rotation are given.
reading-jjf2003-input-matrix = The input matrix called Ā_a and later Ā_g is the same 4 × 6 matrix, in units of local gravity.
reading-jjf2003-k-azx = K_axz appears twice in the list; one of them is K_azx.
reading-jjf2003-k-gzy = The list of five gyro cross coupling coefficients lacks K_gzy (Y axis onto Z axis); all six are given.
reading-jjf2003-positions = The twelve positions are X, Y, Z up, then down, each at two headings 180° apart about the vertical.
reading-jjf2003-u-gx1 = N_gx1 and N_gx2 in the sum are U_gx1 and U_gx2, the readings of eq. (7).
reading-jjf2003-table-rate = The input X of a point is the angle turned by the table's encoder divided by the time; where no encoder was recorded, the rate of the label.
reading-jjf2003-turned-angle = Turns by a known angle replace constant rates: the gyro's output minus the adjacent rests, integrated over the turn, is divided by the angle. This is not the clause's method.
reading-jjf1536-output-rate = The output of a unit that accumulates angles is the mean of its increments per second: the angle gained over the segment divided by its time.
reading-jjf1536-table-rate = The input rate of a point is the angle turned by the table's encoder divided by the time; where no encoder was recorded, the rate of the label.
reading-jjf1536-zero-time = The sum over the positions is divided by the whole of 4·T (n·T for n positions); as printed, it reads as a division by 4 and a multiplication by T. Where the durations differ, the mean of N/T is taken. It is the mean over this switch-on: over all time a zero that wanders slowly (1/f) has another, which may be off by more than U.
reading-jjf1536-earth-cancels = The axis points equally often in opposite directions, so that Earth's rotation cancels; positions for which this does not hold give no zero offset. What positions that are crooked by their stated mounts leave of it is taken off, where latitude and north are known.
reading-jjf1536-turns-divisor = The difference of both directions is divided by the whole of 2 × 360 × n; the π of (17) is n, the number of turns. The ratio (rad) is multiplied by 180/π and given in degrees.
reading-jjf1536-l-yz = The second line of (9) is L_yz (rotation about Z, Y reads); L_yx is printed.
reading-jjf1536-index-order = The first index is the axis that reads, the second the axis of rotation, as in eq. (1) and (7): the misalignment of the X axis to the Y axis is L_yx. Table 3, 7.3 and Appendix C mix the order.
reading-jjf1536-turned-angle = 2 × 360 × n is the angle turned forward plus the angle turned back, from the table's encoder or else from the label. Where the two directions took different times, the zero offset of 7.2 times the difference is subtracted.
reading-jjf1536-product = The sign after the inverse matrix is a product: A = L⁻¹·(N − B·T).
reading-jjf1536-attitude = By (B.1), heading is atan2(−T12, T22) and roll atan2(−T31, T33), over all quadrants.
reading-joint-method = The patent's formulas are truncated; they are read as: least squares, weighted by the covariance of the samples, for scale factor times installation error and for bias, over all dynamic and static samples; then bias and g-sensitivity from the rests; repeated until convergence.
reading-joint-g-earth = Earth's rotation is a known input where the latitude is stated and the rests do not contradict it: unlike the value by eq. (7), the g-sensitivity does not include it.
reading-joint-fit-offset = The offset is the mean of reading minus K·rate over the rate points about the axis, with K from the joint fit; it includes bias, g-sensitivity and Earth's rotation at that attitude.
reading-joint-gravity-alone = With gravity as the only reference, |K⁻¹·(a − B)| = g in every rest. The body axes are then defined by the accelerometers: z is the z accelerometer's own axis, y lies in the plane of the y and z accelerometers; K_yx, K_zx and K_zy are zero by definition.
reading-joint-gravity-moves = Without a table the gyro matrix is determined from the moves between rests: its readings, integrated over a move, must rotate the vertical of one rest into that of the next.
