## 运行页面。

pages-light = 浅色
pages-dark = 深色
pages-no-such-page = 没有这个页面
pages-not-answered = 无法显示
pages-no-database = 无法访问目录数据库；本页会自动重试

pages-line = 产线
    .about = 各测试台当前的工作，以及产线今日的产出
pages-line-no-station = 此数据目录中尚未从任何测试台采集过数据。

pages-runs = 校准运行
    .about = 所有运行及其每一步骤的状态
pages-runs-none = 此数据目录中尚无任何运行。
