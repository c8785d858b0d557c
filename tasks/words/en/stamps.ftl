stamps-packets = The rows were stamped as packets arrived ({ $size } samples in { $every } ms on average). The readings were placed at even instants, { $rate } Hz, with a standard uncertainty of { $u } ms; the stamps scatter about these by { $most } ms, and their mean delay remains.{ $missing ->
        [0] {""}
        [one] {" "}1 sample is missing.
       *[other] {" "}{ $missing } samples are missing.
    }
