## 记录的参考所说明的内容，以及未予采用的部分。

reference-smoothed = 位姿按其自身噪声作了平滑：角速度取姿态的导数，至 { $attitude } Hz；比力含位置的二阶导数，至 { $place } Hz。更高频率处位姿噪声大于运动本身，未作比较。
reference-smoothed-attitude = 位姿按其自身噪声作了平滑：角速度取姿态的导数，至 { $attitude } Hz。更高频率处位姿噪声大于运动本身，未作比较。
reference-without-positions = 位姿不含位置（px、py、pz）：物体运动时的比力未知。加速度计只在静止时段作了比较，占 { $percent } %；请同时记录位置。
reference-lost = 记录的 { $unknown } % 时间未作比较：其中 { $missing } % 时间缺少位姿（连续缺失多于 { $frames } 帧处未作插值），各缺口两侧及首尾处位姿的导数未知。
reference-labels-against-gravity = 与重力相矛盾的标注未予采用：{ $segments }。
reference-rests-disturbed = { $segments } 中有 { $rows } 行明显偏离所在静止段的其余数据，似因触碰或已开始运动，未予采用。
reference-labels-against-rate = 速率与{ $table ->
    [yes] 编码器
   *[no] 陀螺
}相矛盾的标注未予采用：{ $segments }。
reference-nuisances = 位姿的延迟和铅垂方向的倾斜在跟踪系统与单元之间属常见现象：在此类记录的每个模型中均予以拟合，并非单元的故障。
reference-turned = 被跟踪体的轴相对单元的轴偏转 { $degrees }°，陀螺仪与加速度计所示一致。此属常见；位姿已按此转换到单元的轴系。
reference-triads-apart = 相对于被跟踪体，陀螺仪各轴与加速度计各轴的排列不一致：其中一组的列被互换或反向，安装方式不会造成这种情况。位姿未作转换；请对照图样核对两组的轴，并用 --axes 重新导入。
reference-unit-clock = 采集时按数据帧的到达时刻比对了单元时钟与转台时钟：读数延迟中由时钟引起的部分为 { $delay } ms ± { $U } ms（k = 2），其余为单元自身的延迟。
reference-slow = 转台角度每 { $every } s 记录一次，不足以反映其间角速率的变化：记录中 { $percent } % 的时间（加减速及其前后）未作比较。
